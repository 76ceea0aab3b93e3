"""What a fit aims at: curves over time with their errors, from files, trains, laws and models."""
