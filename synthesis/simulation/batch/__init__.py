"""Many joints at once, in compiled code: dry friction, saturation, walls, sampled controllers."""
