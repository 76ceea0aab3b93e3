"""Studies and timings, run by hand."""
