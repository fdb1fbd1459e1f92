//! A wrong body file is an error, never a panic.

use std::collections::HashMap;

use safetensors::SafeTensors;
use safetensors::tensor::{Dtype, TensorView, serialize};
use toile_geometry::body::{Body, BodyError};

use super::artifact;

/// What reading the file says after one tensor was replaced, or the metadata.
fn reading_with(tensor: Option<(&str, TensorView<'_>)>, meta: impl FnOnce(String) -> String) -> String {
    let bytes = artifact("body.safetensors");
    let (_, header) = SafeTensors::read_metadata(&bytes).unwrap();
    let text = meta(header.metadata().as_ref().unwrap()["toile"].clone());
    let mut tensors: Vec<_> = SafeTensors::deserialize(&bytes).unwrap().tensors();
    if let Some((name, view)) = tensor {
        tensors.retain(|(other, _)| other != name);
        tensors.push((name.to_owned(), view));
    }
    let changed = serialize(tensors, Some(HashMap::from([("toile".to_owned(), text)]))).unwrap();
    match Body::from_safetensors(&changed) {
        Err(BodyError::File(reason)) => reason,
        Err(other) => panic!("{other}"),
        Ok(_) => "read".to_owned(),
    }
}

fn reading_with_tensor(name: &str, dtype: Dtype, shape: &[usize], bytes: &[u8]) -> String {
    let view = TensorView::new(dtype, shape.to_vec(), bytes).unwrap();
    reading_with(Some((name, view)), |meta| meta)
}

#[test]
fn the_file_written_again_is_read() {
    assert_eq!(reading_with(None, |meta| meta), "read");
}

#[test]
fn a_tensor_of_another_shape_or_type_is_refused() {
    let zeros = vec![0_u8; 104 * 3 * 4];
    let found = reading_with_tensor("joint_heads", Dtype::F32, &[3, 104], &zeros);
    assert_eq!(found, "joint_heads is F32 [3, 104], not F32 [104, 3]");
    let found = reading_with_tensor("joint_heads", Dtype::I32, &[104, 3], &zeros);
    assert_eq!(found, "joint_heads is I32 [104, 3], not F32 [104, 3]");
    let found = reading_with_tensor("shape_basis", Dtype::I16, &[0, 10, 3], &[]);
    assert_eq!(found, "no vertices, coefficients or joints");
}

#[test]
fn indices_out_of_range_and_numbers_that_are_not_finite_are_refused() {
    let far = [13_718_u32, 0, 1].map(u32::to_le_bytes).concat();
    let found = reading_with_tensor("triangles", Dtype::U32, &[1, 3], &far);
    assert!(found.contains("vertices that there are not"), "{found}");
    let nan = f32::NAN.to_le_bytes().repeat(104 * 3);
    let found = reading_with_tensor("joint_heads", Dtype::F32, &[104, 3], &nan);
    assert!(found.contains("not finite"), "{found}");
    let far = 9999_u16.to_le_bytes().repeat(13_718 * 9);
    let found = reading_with_tensor("skin_joints", Dtype::U16, &[13_718, 9], &far);
    assert!(found.contains("skin weights"), "{found}");
    let own_parent = (0..104_i32).flat_map(i32::to_le_bytes).collect::<Vec<_>>();
    let found = reading_with_tensor("joint_parents", Dtype::I32, &[104], &own_parent);
    assert!(found.contains("not a tree"), "{found}");
    let far = [0, 99_999_i32].map(i32::to_le_bytes).concat().repeat(11);
    let found = reading_with_tensor("measure_ranges", Dtype::I32, &[11, 2], &far);
    assert!(found.contains("measure_ranges"), "{found}");
}

#[test]
fn other_names_than_the_program_knows_are_refused() {
    for (known, other, reason) in [
        ("toile-body/1", "toile-body/9", "format"),
        ("\"proportions\"", "\"posture\"", "phenotypes"),
        ("\"maxheight\"", "\"tallest\"", "anchors"),
        ("\"thigh\"", "\"calf\"", "measurements"),
        ("\"clavicle.L\"]", "\"no-such-bone\"]", "humanoid joint"),
    ] {
        let found = reading_with(None, |meta| meta.replace(known, other));
        assert!(found.contains(reason), "{known} -> {other}: {found}");
    }
}

#[test]
fn a_truncated_file_is_refused_wherever_it_ends() {
    let bytes = artifact("body.safetensors");
    for length in [0, 7, 8, 100, 5000, 1_000_000, bytes.len() - 1] {
        assert!(Body::from_safetensors(&bytes[..length]).is_err(), "{length} bytes");
    }
}
