"""What surveyors upload: trace files, CSV and JSON, and where along the walk each reading was heard."""
