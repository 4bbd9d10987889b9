"""What the world is: impedances, actuators, uncertainty, controllers, the closed loop (★)."""
