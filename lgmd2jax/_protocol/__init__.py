"""Protocols: conditions with their targets, read from TOML."""
