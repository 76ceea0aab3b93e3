"""What public functions are given, looked at before they do anything."""
