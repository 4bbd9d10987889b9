"""`Spec` to constraints and arrays on the frequency grid."""
