//! The chain as one ONNX graph: window `[16, 1, 42]` to field `[1, 27742]`.

use crate::networks::{DT, GROUPS, Layer, Networks, Places};
use crate::onnx::{Attribute, Dim, Graph, Kind, Model, Node, Opset, Shape, Tensor, TensorKind, Value};
use prost::Message;

/// Builds a graph node by node.
#[derive(Default)]
struct Builder {
    graph: Graph,
}

impl Builder {
    /// A tensor of f32.
    fn floats(&mut self, name: &str, dims: &[i64], numbers: impl IntoIterator<Item = f32>) -> String {
        let raw_data = numbers.into_iter().flat_map(f32::to_le_bytes).collect();
        self.tensor(name, dims, 1, raw_data)
    }

    /// A tensor of whole numbers.
    fn whole(&mut self, name: &str, dims: &[i64], numbers: impl IntoIterator<Item = i64>) -> String {
        let raw_data = numbers.into_iter().flat_map(i64::to_le_bytes).collect();
        self.tensor(name, dims, 7, raw_data)
    }

    fn tensor(&mut self, name: &str, dims: &[i64], data_type: i32, raw_data: Vec<u8>) -> String {
        self.graph.initializer.push(Tensor { dims: dims.to_vec(), data_type, name: name.into(), raw_data });
        name.into()
    }

    /// A node with one output, which has its name.
    fn node(&mut self, name: &str, op: &str, inputs: &[&str], attributes: &[(&str, i64)]) -> String {
        self.node_with(name, op, inputs, attributes, &[name])
    }

    fn node_with(
        &mut self,
        name: &str,
        op: &str,
        inputs: &[&str],
        attributes: &[(&str, i64)],
        outputs: &[&str],
    ) -> String {
        let own = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let attribute = |(name, i): &(&str, i64)| Attribute { name: (*name).into(), i: *i, kind: 2 };
        self.graph.node.push(Node {
            input: own(inputs),
            output: own(outputs),
            name: name.into(),
            op_type: op.into(),
            attribute: attributes.iter().map(attribute).collect(),
        });
        outputs.last().map_or(String::new(), |output| (*output).into())
    }

    /// Dense layers one behind the other.
    fn stack(&mut self, prefix: &str, layers: &[Layer<'_>], mut x: String) -> String {
        for (k, layer) in layers.iter().enumerate() {
            let name = format!("{prefix}_{k}");
            let (rows, columns) = (layer.rows as i64, layer.columns as i64);
            let w = self.floats(&format!("{name}_w"), &[rows, columns], layer.weights.iter().copied());
            let b = self.floats(&format!("{name}_b"), &[rows], layer.bias.iter().copied());
            x = self.node(&name, "Gemm", &[&x, &w, &b], &[("transB", 1)]);
            if layer.relu {
                x = self.node(&format!("{name}_relu"), "Relu", &[&x], &[]);
            }
        }
        x
    }
}

/// The bytes of the model.
pub fn model(networks: &Networks) -> anyhow::Result<Vec<u8>> {
    let mut builder = Builder::default();
    let b = &mut builder;
    let mut x = String::from("window");
    let one = b.whole("one", &[1], [1]);
    let zeroth = b.whole("zeroth", &[1], [0]);
    for k in 0..3 {
        let input = networks.layer(&format!("gru.{k}.input"), false)?;
        let hidden = networks.layer(&format!("gru.{k}.hidden"), false)?;
        // Ours and PyTorch's order is r, z, n; that of ONNX z, r, h.
        let gates = |numbers: &[f32]| {
            let third = numbers.len() / 3;
            [&numbers[third..2 * third], &numbers[..third], &numbers[2 * third..]].concat()
        };
        let w = b.floats(&format!("gru{k}_w"), &[1, 78, input.columns as i64], gates(input.weights));
        let r = b.floats(&format!("gru{k}_r"), &[1, 78, 26], gates(hidden.weights));
        let bias = [gates(input.bias), gates(hidden.bias)].concat();
        let bias = b.floats(&format!("gru{k}_b"), &[1, 156], bias);
        let (all, last) = (format!("gru{k}_all"), format!("gru{k}_last"));
        let attributes = [("hidden_size", 26), ("linear_before_reset", 1)];
        b.node_with(&format!("gru{k}"), "GRU", &[&x, &w, &r, &bias], &attributes, &[&all, &last]);
        x = if k < 2 {
            b.node(&format!("gru{k}_flat"), "Squeeze", &[&all, &one], &[])
        } else {
            b.node("gru_out", "Squeeze", &[&last, &zeroth], &[])
        };
    }
    let latent = b.stack("head", &[networks.layer("head", false)?], x);
    let out = b.stack("spnn", &networks.spnn()?, latent.clone());
    let flat = b.whole("flat", &[1], [-1]);
    let out = b.node("out", "Reshape", &[&out, &flat], &[]);
    let (minus, size) = (b.node("minus", "Neg", &[&out], &[]), b.node("size", "Abs", &[&out], &[]));
    let zero = b.floats("zero", &[1], [0.0]);
    let all = b.node("all", "Concat", &[&out, &minus, &size, &zero], &[("axis", 0)]);
    let places = Places::new();
    let square = b.whole("skew_at", &[13, 13], places.skew);
    let skew = b.node("skew", "Gather", &[&all, &square], &[]);
    let square = b.whole("factor_at", &[13, 13], places.factor);
    let factor = b.node("factor", "Gather", &[&all, &square], &[]);
    let column = b.whole("de_at", &[13, 1], places.de);
    let de = b.node("de", "Gather", &[&all, &column], &[]);
    let column = b.whole("ds_at", &[13, 1], places.ds);
    let ds = b.node("ds", "Gather", &[&all, &column], &[]);
    let turned = b.node("turned", "Transpose", &[&factor], &[]);
    let inner = b.node("inner", "MatMul", &[&turned, &ds], &[]);
    let friction = b.node("friction", "MatMul", &[&factor, &inner], &[]);
    let motion = b.node("motion", "MatMul", &[&skew, &de], &[]);
    let rate = b.node("rate", "Add", &[&motion, &friction], &[]);
    let dt = b.floats("dt", &[1], [DT]);
    let change = b.node("change", "Mul", &[&rate, &dt], &[]);
    let change = b.node("change_flat", "Reshape", &[&change, &flat], &[]);
    let start = b.node("start", "Reshape", &[&latent, &flat], &[]);
    let end = b.node("end", "Add", &[&start, &change], &[]);
    let end = b.node("end_padded", "Concat", &[&end, &zero], &[("axis", 0)]);
    let (mut first, mut fields) = (0_i64, Vec::new());
    for (group, dealt) in GROUPS {
        let layers = networks.decoder(group)?;
        let width = layers.first().map_or(0, |layer| layer.columns);
        // The rest of the bottleneck is the zero behind the 13 latents.
        let at = (0..width as i64).map(|k| if k < dealt as i64 { first + k } else { 13 });
        let at = b.whole(&format!("{group}_at"), &[1, width as i64], at);
        let x = b.node(&format!("{group}_latent"), "Gather", &[&end, &at], &[]);
        fields.push(b.stack(group, &layers, x));
        first += dealt as i64;
    }
    let fields: Vec<&str> = fields.iter().map(String::as_str).collect();
    b.node("field", "Concat", &fields, &[("axis", 1)]);
    let value = |name: &str, dims: &[i64]| Value {
        name: name.into(),
        kind: Some(Kind {
            tensor: Some(TensorKind {
                elem_type: 1,
                shape: Some(Shape { dim: dims.iter().map(|value| Dim { value: *value }).collect() }),
            }),
        }),
    };
    b.graph.name = "chain".into();
    b.graph.input = vec![value("window", &[16, 1, 42])];
    b.graph.output = vec![value("field", &[1, 27_742])];
    let opset = Opset { domain: String::new(), version: 17 };
    Ok(Model { ir_version: 8, graph: Some(builder.graph), opset: vec![opset] }.encode_to_vec())
}
