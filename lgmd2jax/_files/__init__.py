"""Files: written whole or not at all, found by path or by the name of what is shipped."""
