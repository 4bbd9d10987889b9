"""A map: one synthesis for each cell of a plane of two specification keys, in parallel, resumable."""
