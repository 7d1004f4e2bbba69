//! The elements and attributes that the reader knows.
//!
//! Attributes that only matter to MuJoCo's solver or to rendering are known and not kept.

/// Top-level elements that say nothing about the robot's mechanics.
pub(super) const SKIPPED_SECTIONS: &[&str] =
    &["option", "size", "statistic", "visual", "asset", "sensor", "keyframe", "custom"];
/// Top-level elements that are read.
pub(super) const SECTIONS: &[&str] = &["compiler", "default", "worldbody", "contact", "actuator"];
/// Elements that change the mechanics in a way that is not simulated, and what to do about it.
pub(super) const UNSUPPORTED: &[(&str, &str)] = &[
    ("equality", "equality constraints are not simulated: remove this section, and what it constrains"),
    ("include", "included files are not read: put their elements here"),
    ("tendon", "tendons are not simulated: remove this section"),
    ("deformable", "soft bodies are not simulated: remove this section"),
    ("extension", "plugins are not simulated: remove this section"),
];
/// Elements with defaults.
pub(super) const DEFAULT_ELEMENTS: &[&str] = &["joint", "geom", "motor", "position"];
/// Defaults of elements that are skipped.
pub(super) const SKIPPED_DEFAULTS: &[&str] =
    &["site", "camera", "light", "mesh", "material", "equality", "tendon"];
/// Elements of a body that are read.
pub(super) const BODY_ELEMENTS: &[&str] = &["inertial", "joint", "freejoint", "geom", "body"];
/// Elements of a body without mass, motion or contact.
pub(super) const SKIPPED_BODY_ELEMENTS: &[&str] = &["site", "camera", "light"];

/// Attributes of an element.
pub(super) fn attributes_of(tag: &str) -> &'static [&'static str] {
    match tag {
        "compiler" => &[
            "angle",
            "autolimits",
            "eulerseq",
            "coordinate",
            "inertiafromgeom",
            "meshdir",
            "texturedir",
            "assetdir",
        ],
        "body" => &["name", "childclass", "pos", "quat", "euler", "axisangle"],
        "inertial" => &["mass", "pos", "quat", "euler", "axisangle", "diaginertia", "fullinertia"],
        "freejoint" => &["name", "group", "align"],
        "joint" => &[
            "name",
            "class",
            "type",
            "pos",
            "axis",
            "range",
            "limited",
            "armature",
            "frictionloss",
            "damping",
            "ref",
            "stiffness",
            "springref",
            "actuatorfrcrange",
            "actuatorfrclimited",
            "margin",
            "group",
            "solreflimit",
            "solimplimit",
            "solreffriction",
            "solimpfriction",
        ],
        "geom" => &[
            "name",
            "class",
            "type",
            "size",
            "pos",
            "quat",
            "euler",
            "axisangle",
            "fromto",
            "contype",
            "conaffinity",
            "condim",
            "priority",
            "friction",
            "solref",
            "solimp",
            "solmix",
            "margin",
            "gap",
            "group",
            "rgba",
            "material",
            "mass",
            "density",
            "mesh",
        ],
        "motor" => &[
            "name",
            "class",
            "joint",
            "gear",
            "ctrlrange",
            "ctrllimited",
            "forcerange",
            "forcelimited",
            "group",
        ],
        "position" => &[
            "name",
            "class",
            "joint",
            "gear",
            "ctrlrange",
            "ctrllimited",
            "forcerange",
            "forcelimited",
            "group",
            "kp",
            "kv",
            "dampratio",
            "inheritrange",
        ],
        "exclude" => &["name", "body1", "body2"],
        _ => &[],
    }
}
