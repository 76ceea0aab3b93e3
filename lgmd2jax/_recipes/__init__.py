"""Recipes of fits and sweeps, read from TOML."""
