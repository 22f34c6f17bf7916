"""The zoo: robots of others and made-up ones, described by their models alone, walk."""
