"""Many runs at once: starts and values of parameters as arrays, measures of every run, kept where memory is bounded."""
