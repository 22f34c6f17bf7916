"""What a run amounts to: metrics, causes of falls, tables, plots, report page, output folder."""
