"""Tables and figures of [RH02]."""
