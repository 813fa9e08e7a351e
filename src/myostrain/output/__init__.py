"""What a run leaves behind: fields, probes, metrics, figures."""
