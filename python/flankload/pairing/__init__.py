"""Two bodies on their axes: ratio, sites, path of contact, interference, friction, period."""
