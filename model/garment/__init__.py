"""A garment as the network sees it: canonical graph, features, binding to the body."""
