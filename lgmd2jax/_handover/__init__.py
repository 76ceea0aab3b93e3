"""The hand-over file model.json, and models by name."""
