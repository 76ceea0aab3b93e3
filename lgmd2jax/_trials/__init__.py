"""Recorded trials: spike times by animal and condition, read from the files that laboratories have."""
