"""One scene at many values of its parameters: designs, blocks that any executor runs, and what comes of them."""
