"""A fleet's folder, here or in a bucket: whose runs and models it holds, and what they are called."""
