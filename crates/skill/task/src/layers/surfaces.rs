//! Surfaces by name: a preset says `ball_params = "hard"`, and the numbers are in the surface's own file.

use std::fs;
use std::path::Path;

use toml::Value;

use super::{LayerError, Node, Origin, Tree};

/// Surfaces in the binary: name, file and TOML text.
const BUILTIN: [(&str, &str, &str); 2] = [
    ("hard", "surfaces/hard.toml", include_str!("../../../../../configs/surfaces/hard.toml")),
    ("grass", "surfaces/grass.toml", include_str!("../../../../../configs/surfaces/grass.toml")),
];

impl Tree {
    /// Replaces the names of surfaces by their numbers: in `ball_params` and `randomization.surfaces` of a task, of a run
    /// preset's task, and of its phases. A name is a built-in one or the path of a `.toml` file, relative to `folder`.
    ///
    /// # Errors
    /// If there is no such surface, or its file is not one.
    pub fn expand_surfaces(&mut self, folder: &Path) -> Result<(), LayerError> {
        let phases = match self.0.at("phases") {
            Some(Node::List(phases)) => phases.len(),
            _ => 0,
        };
        let tasks = [String::new(), "task.".to_owned()]
            .into_iter()
            .chain((0..phases).map(|k| format!("phases.{k}.task.")));
        for task in tasks {
            if let Some(node) = self.0.at_mut(&format!("{task}ball_params"))
                && let Node::Leaf { value: Value::String(name), origin } = &*node
            {
                *node = Surface::read(name, origin, folder)?.ball;
            }
            if let Some(node) = self.0.at_mut(&format!("{task}randomization.surfaces"))
                && let Node::Leaf { value: Value::Array(items), origin } = &*node
                && items.iter().any(Value::is_str)
            {
                let surfaces = items.iter().map(|item| match item {
                    Value::String(name) => Ok(Surface::read(name, origin, folder)?.contact(origin)),
                    other => Ok(Node::of(other.clone(), origin)),
                });
                *node = Node::List(surfaces.collect::<Result<_, LayerError>>()?);
            }
        }
        Ok(())
    }
}

/// A surface file.
struct Surface {
    name: String,
    /// Its table `ball_params`.
    ball: Node,
}

impl Surface {
    /// The surface of a name at `origin`.
    fn read(name: &str, origin: &Origin, folder: &Path) -> Result<Self, LayerError> {
        let mut tree = if let Some((_, file, text)) = BUILTIN.iter().find(|(builtin, ..)| *builtin == name) {
            Tree::parse(file, text)?
        } else {
            let place = match origin {
                Origin::Set(text) => format!("--set {text}"),
                origin => origin.to_string(),
            };
            let fail = |message: String| LayerError { place, message };
            if !name.ends_with(".toml") {
                let names = BUILTIN.map(|(name, ..)| name).join(", ");
                return Err(fail(format!(
                    "expected a surface ({names}) or the path of a .toml file, found '{name}'"
                )));
            }
            let path = folder.join(name);
            let text = fs::read_to_string(&path)
                .map_err(|error| fail(format!("cannot read the surface {}: {error}", path.display())))?;
            Tree::parse(&path.to_string_lossy(), &text)?
        };
        let title = tree.value("name").and_then(|name| name.as_str().map(str::to_owned));
        let ball = tree.take("ball_params").ok_or_else(|| LayerError {
            place: name.to_owned(),
            message: "expected a surface with a table [ball_params], found none".to_owned(),
        })?;
        let ball = match origin {
            Origin::Set(_) => Node::of(ball.0.to_value(), origin),
            _ => ball.0,
        };
        Ok(Self { name: title.unwrap_or_else(|| name.to_owned()), ball })
    }

    /// Its entry in `randomization.surfaces`.
    fn contact(self, origin: &Origin) -> Node {
        let Node::Table(mut ball) = self.ball else { return self.ball };
        let mut table = match ball.remove("material") {
            Some(Node::Table(material)) => material,
            _ => Default::default(),
        };
        let damping = ["linear_damping", "angular_damping"].map(|key| ball.remove_entry(key));
        table.extend(damping.into_iter().flatten());
        table.insert("name".to_owned(), Node::of(Value::String(self.name), origin));
        Node::Table(table)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expanded(text: &str, folder: &Path) -> Result<Tree, LayerError> {
        let mut tree = Tree::parse("x.toml", text)?;
        tree.expand_surfaces(folder).map(|()| tree)
    }

    #[test]
    fn the_numbers_of_a_surface_come_from_its_file() {
        let text = "[task]\nball_params = \"hard\"\nrandomization.surfaces = [\"hard\", \"grass\"]";
        let tree = expanded(text, Path::new("")).expect("shipped");
        assert_eq!(tree.value("task.ball_params.material.dynamic_friction"), Some(Value::Float(0.07)));
        assert!(tree.origin("task.ball_params.mass_kg").to_string().starts_with("surfaces/hard.toml:"));
        assert_eq!(tree.value("task.randomization.surfaces.1.angular_damping"), Some(Value::Float(4.95)));
        assert_eq!(tree.value("task.randomization.surfaces.1.name"), Some(Value::String("grass".into())));
        assert_eq!(tree.value("task.randomization.surfaces.1.mass_kg"), None);
    }

    #[test]
    fn a_surface_file_lies_next_to_the_preset_and_an_absent_one_is_reported() {
        let folder = tempfile::tempdir().expect("folder");
        let text = "name = \"yard\"\n[ball_params]\nmass_kg = 0.4\n";
        fs::write(folder.path().join("yard.toml"), text).expect("write");
        let tree = expanded("ball_params = \"yard.toml\"", folder.path()).expect("read");
        assert_eq!(tree.value("ball_params.mass_kg"), Some(Value::Float(0.4)));
        let error = expanded("\nball_params = \"mud\"", folder.path()).expect_err("absent").to_string();
        assert!(error.starts_with("x.toml:2: ") && error.contains("hard, grass") && error.contains("'mud'"));
        assert!(expanded("ball_params = \"mud.toml\"", folder.path()).is_err());
    }
}
