"""The network: retina, medulla, lobula, and what puts them together."""
