"""The processes of passafe, what runs them and what reads their logs."""
