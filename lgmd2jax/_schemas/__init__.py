"""The form of every document that is read, and the one place that checks it; loaded by what reads files alone."""
