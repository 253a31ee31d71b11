"""Many runs of one scene in one call: starts and parameters as arrays."""
