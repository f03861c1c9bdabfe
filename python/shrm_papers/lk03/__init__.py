"""Tables and figures of [LK03]."""
