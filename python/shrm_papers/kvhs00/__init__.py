"""Tables and figures of [KVHS00]."""
