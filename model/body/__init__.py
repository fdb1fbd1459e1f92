"""The body: baking Anny, evaluating it, measuring it, posing it."""
