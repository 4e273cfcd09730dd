"""Two bodies whose flanks touch on circles about parallel axes."""
