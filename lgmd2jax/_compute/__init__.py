"""Where work is done: in batches, by tasks on cores or a cluster, and what XLA is told."""
