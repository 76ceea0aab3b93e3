"""C99 of a model: its source from templates, its size in memory, and what it computes beside the other two models."""
