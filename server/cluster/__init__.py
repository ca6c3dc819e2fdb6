"""Several machines that serve one game: nodes, leases of rooms in PostgreSQL, and the proxy in front of them."""
