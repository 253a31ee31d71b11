"""Programs as files in every target."""
