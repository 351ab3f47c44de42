//! A learned projection as ONNX, opset 13: input `pose`, output `projected`, both of shape `[n, 6]`
//! in single precision, x, y, z in metres, roll, pitch and yaw in radians.
//!
//! The graph computes what [`LearnedProjection`] does, except that it does not wrap angles: they
//! must lie within π of the scaling's centre. The messages are those of onnx.proto3 (field numbers
//! of IR version 8), encoded by hand: they are few.

use crate::manifold::learned::{LearnedProjection, Output};

const IR_VERSION: u64 = 8;
const OPSET: u64 = 13;
/// `TensorProto.FLOAT`.
const FLOAT: u64 = 1;
/// `AttributeProto.INT`.
const INT: u64 = 2;

/// The bytes of the ONNX file, as the module describes it; `metadata` are pairs of key and value
/// that become properties of the model, in their order. Keys should be distinct, which is not
/// checked.
pub fn to_bytes(projection: &LearnedProjection, metadata: &[(&str, String)]) -> Vec<u8> {
    let mut model = Message::default();
    model.number(1, IR_VERSION).text(2, "touchcal").text(3, env!("CARGO_PKG_VERSION"));
    model.message(7, &graph(projection));
    let mut opset = Message::default();
    opset.number(2, OPSET);
    model.message(8, &opset);
    for (key, value) in metadata {
        let mut property = Message::default();
        property.text(1, key).text(2, value);
        model.message(14, &property);
    }
    model.0
}

fn graph(projection: &LearnedProjection) -> Message {
    let scaling = projection.scaling();
    let single = |values: [f64; 6]| values.map(|value| value as f32);
    let mut graph = Message::default();
    let node = |graph: &mut Message, operator: &str, inputs: &[&str], output: &str| {
        graph.message(1, &operation(operator, inputs, output, &[]));
    };
    node(&mut graph, "Sub", &["pose", "input_centre"], "offset");
    node(&mut graph, "Div", &["offset", "input_scale"], "x0");
    let layers = projection.network().layers();
    for (k, layer) in layers.iter().enumerate() {
        let (x, y, weight, bias) = (format!("x{k}"), format!("x{}", k + 1), weight(k), bias(k));
        let last = k + 1 == layers.len();
        let sum = if last { y.clone() } else { format!("sum{k}") };
        graph.message(1, &operation("Gemm", &[&x, &weight, &bias], &sum, &[("transB", 1)]));
        if !last {
            node(&mut graph, "Relu", &[&sum], &y);
        }
        graph.message(5, &tensor(&weight, &[layer.outputs(), layer.inputs()], layer.weights()));
        graph.message(5, &tensor(&bias, &[layer.outputs()], layer.bias()));
    }
    node(&mut graph, "Mul", &[&format!("x{}", layers.len()), "output_scale"], "change");
    let from = if scaling.output == Output::Pose { "output_centre" } else { "pose" };
    node(&mut graph, "Add", &["change", from], "projected");
    graph.text(2, "learned_projection");
    graph.message(5, &tensor("input_centre", &[6], &single(scaling.input_centre)));
    graph.message(5, &tensor("input_scale", &[6], &single(scaling.input_scale)));
    graph.message(5, &tensor("output_scale", &[6], &single(scaling.output_scale())));
    if scaling.output == Output::Pose {
        graph.message(5, &tensor("output_centre", &[6], &single(scaling.output_centre)));
    }
    graph.message(11, &value("pose"));
    graph.message(12, &value("projected"));
    graph
}

fn weight(layer: usize) -> String {
    format!("layers.{layer}.weight")
}

fn bias(layer: usize) -> String {
    format!("layers.{layer}.bias")
}

/// `NodeProto`.
fn operation(operator: &str, inputs: &[&str], output: &str, attributes: &[(&str, u64)]) -> Message {
    let mut node = Message::default();
    for input in inputs {
        node.text(1, input);
    }
    node.text(2, output).text(4, operator);
    for (name, value) in attributes {
        let mut attribute = Message::default();
        attribute.text(1, name).number(3, *value).number(20, INT);
        node.message(5, &attribute);
    }
    node
}

/// `TensorProto`.
fn tensor(name: &str, shape: &[usize], values: &[f32]) -> Message {
    let mut tensor = Message::default();
    for size in shape {
        tensor.number(1, *size as u64);
    }
    tensor.number(2, FLOAT).text(8, name);
    tensor.bytes(9, &values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>());
    tensor
}

/// `ValueInfoProto` of shape `[n, 6]`.
fn value(name: &str) -> Message {
    let (mut any, mut six, mut shape) = (Message::default(), Message::default(), Message::default());
    any.text(2, "n");
    six.number(1, 6);
    shape.message(1, &any).message(1, &six);
    let (mut tensor, mut kind, mut value) = (Message::default(), Message::default(), Message::default());
    tensor.number(1, FLOAT).message(2, &shape);
    kind.message(1, &tensor);
    value.text(1, name).message(2, &kind);
    value
}

/// A message of protocol buffers as it is written: a tag and a value for each field.
#[derive(Default)]
struct Message(Vec<u8>);

impl Message {
    fn number(&mut self, field: u64, value: u64) -> &mut Self {
        self.varint(field << 3).varint(value)
    }

    fn text(&mut self, field: u64, text: &str) -> &mut Self {
        self.bytes(field, text.as_bytes())
    }

    fn message(&mut self, field: u64, message: &Message) -> &mut Self {
        self.bytes(field, &message.0)
    }

    fn bytes(&mut self, field: u64, bytes: &[u8]) -> &mut Self {
        self.varint(field << 3 | 2).varint(bytes.len() as u64);
        self.0.extend_from_slice(bytes);
        self
    }

    /// Seven bits a byte, the lowest first; the eighth says that more follow.
    fn varint(&mut self, mut value: u64) -> &mut Self {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
        self
    }
}
