//! Policy files: the self-describing contract, ONNX out and in.
