"""The subcommands of the surefix command line, one file each."""
