"""What every node of the loop has: drivers, inputs, quality of service, clock, diagnostics, parameters, events."""
