"""The way to an answer: attempts at the program, searches where no attempt holds, and what is sent instead."""
