"""The bounded Levenberg-Marquardt solver, on optimistix' interface."""
