"""The search that fits of curves and fits of alarms have in common: random starts in the unit box, and descents."""
