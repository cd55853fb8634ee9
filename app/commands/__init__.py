"""The subcommands of the surefix command line, a module each, and what they are made of."""
