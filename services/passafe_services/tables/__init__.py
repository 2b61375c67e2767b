"""Tables of a log: one for each topic, a row for each message, a column for each number that has a name."""
