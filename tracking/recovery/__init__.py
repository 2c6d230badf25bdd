"""What happens to parts that are not seen: carried, looked for, taken back."""
