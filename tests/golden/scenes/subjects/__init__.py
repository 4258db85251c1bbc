"""The scenes of the golden cases, by what they show."""
