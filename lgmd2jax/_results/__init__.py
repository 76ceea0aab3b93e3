"""Results as folders, written and read."""
