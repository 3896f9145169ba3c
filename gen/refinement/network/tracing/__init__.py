"""From what is left to effects: judged on what was left out, one after the other, and which of them are needed."""
