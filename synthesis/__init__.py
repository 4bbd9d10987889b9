"""From a specification to a proven controller."""
