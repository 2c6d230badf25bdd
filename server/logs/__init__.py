"""Logs: structured, one line an event, without secrets; the same in the API and in workers."""
