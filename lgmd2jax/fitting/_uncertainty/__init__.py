"""How well a fit is determined: covariance, profiles, posterior."""
