//! GMR's pickles: what numpy writes is read, and nothing is run.

use std::path::Path;

use crate::pickle::Machine;
use crate::testing::{model, spec};
use crate::{Clip, KickLeg, MotionError, ReadOptions};

fn parse(bytes: &[u8]) -> Result<Clip, MotionError> {
    crate::gmr::parse_gmr(bytes, Path::new("a.pkl"), &model(), &spec(), &ReadOptions::default())
}

/// The bytes that hexadecimal digits stand for.
pub(crate) fn bytes(hex: &str) -> Vec<u8> {
    let digits: Vec<u8> = hex.bytes().filter(u8::is_ascii_hexdigit).collect();
    digits
        .chunks_exact(2)
        .map(|pair| u8::from_str_radix(&String::from_utf8_lossy(pair), 16).expect("hex"))
        .collect()
}

/// numpy 2, protocol 4, f8.
pub(crate) const NUMPY_4: &str = "\
    800495ab010000000000007d94288c03667073944b1e8c08726f6f745f706f73948c166e756d70792e5f636f72652e6d756c74696172726179948c0c\
    5f7265636f6e7374727563749493948c056e756d7079948c076e6461727261799493944b0085944301629487945294284b014b024b03869468068c05\
    64747970659493948c02663894898887945294284b038c013c944e4e4e4affffffff4affffffff4b0074946289433000000000000000000000000000\
    000000666666666666e63f9a9999999999b93f0000000000000000666666666666e63f947494628c08726f6f745f726f7494680568084b008594680a\
    87945294284b014b024b0486946812894340000000000000000000000000000000000000000000000000000000000000f03f00000000000000000000\
    000000000000333333333333e33f9a9999999999e93f947494628c07646f665f706f7394680568084b008594680a87945294284b014b024b02869468\
    128943209a9999999999b93f9a9999999999c9bf333333333333d33f9a9999999999d9bf947494628c0e6c6f63616c5f626f64795f706f73944e8c0e\
    6c696e6b5f626f64795f6c697374944e752e";

/// Protocol 5, f4.
pub(crate) const NUMPY_5: &str = "\
    80059544010000000000007d94288c03667073944b1e8c08726f6f745f706f73948c136e756d70792e5f636f72652e6e756d65726963948c0b5f6672\
    6f6d6275666665729493942896180000000000000000000000000000003333333fcdcccc3d000000003333333f948c056e756d7079948c0564747970\
    659493948c02663494898887945294284b038c013c944e4e4e4affffffff4affffffff4b007494624b024b0386948c014394749452948c08726f6f74\
    5f726f74946805289620000000000000000000000000000000000000000000803f00000000000000009a99193fcdcc4c3f94680c4b024b0486946810\
    749452948c07646f665f706f7394680528961000000000000000cdcccc3dcdcc4cbe9a99993ecdccccbe94680c4b024b0286946810749452948c0e6c\
    6f63616c5f626f64795f706f73944e8c0e6c696e6b5f626f64795f6c697374944e752e";

/// Protocol 2, f8, Fortran order.
pub(crate) const NUMPY_2: &str = "\
    80027d710028580300000066707371014b1e5808000000726f6f745f706f737102636e756d70792e5f636f72652e6d756c746961727261790a5f7265\
    636f6e7374727563740a7103636e756d70790a6e6461727261790a71044b00857105635f636f646563730a656e636f64650a71065801000000627107\
    58060000006c6174696e31710886710952710a87710b52710c284b014b024b0386710d636e756d70790a64747970650a710e58020000006638710f89\
    88877110527111284b0358010000003c71124e4e4e4affffffff4affffffff4b007471136288680658390000000000000000000000c29ac299c299c2\
    99c299c299c2b93f00000000000000000000000000000000666666666666c3a63f666666666666c3a63f711468088671155271167471176258080000\
    00726f6f745f726f747118680368044b00857119680a87711a52711b284b014b024b0486711c68118868065849000000000000000000000000000000\
    00000000000000000000000000000000000000000000000000000000333333333333c3a33f000000000000c3b03fc29ac299c299c299c299c299c3a9\
    3f711d680886711e52711f747120625807000000646f665f706f737121680368044b00857122680a877123527124284b014b024b0286712568118868\
    065838000000c29ac299c299c299c299c299c2b93f333333333333c3933fc29ac299c299c299c299c299c389c2bfc29ac299c299c299c299c299c399\
    c2bf7126680886712752712874712962580e0000006c6f63616c5f626f64795f706f73712a4e580e0000006c696e6b5f626f64795f6c697374712b4e\
    752e";

/// Lists, protocol 0.
pub(crate) const LISTS_0: &str = "\
    286470300a566670730a70310a4633302e300a7356726f6f745f706f730a70320a286c70330a286c70340a46302e300a6146302e300a6146302e370a\
    6161286c70350a46302e310a6146302e300a6146302e370a61617356726f6f745f726f740a70360a286c70370a286c70380a46302e300a6146302e30\
    0a6146302e300a6146312e300a6161286c70390a46302e300a6146302e300a6146302e360a6146302e380a61617356646f665f706f730a7031300a28\
    6c7031310a286c7031320a46302e310a61462d302e320a6161286c7031330a46302e330a61462d302e340a616173566c6f63616c5f626f64795f706f\
    730a7031340a4e73566c696e6b5f626f64795f6c6973740a7031350a4e732e";

/// Lists and a numpy scalar, protocol 4.
pub(crate) const LISTS_4: &str = "\
    8004957e010000000000007d94288c03667073948c166e756d70792e5f636f72652e6d756c74696172726179948c067363616c61729493948c056e75\
    6d7079948c0564747970659493948c02663894898887945294284b038c013c944e4e4e4affffffff4affffffff4b0074946243080000000000003e40\
    94869452948c08726f6f745f706f73945d94285d9428470000000000000000470000000000000000473fe6666666666666655d9428473fb999999999\
    999a470000000000000000473fe666666666666665658c08726f6f745f726f74945d94285d9428470000000000000000470000000000000000470000\
    000000000000473ff0000000000000655d9428470000000000000000470000000000000000473fe3333333333333473fe999999999999a65658c0764\
    6f665f706f73945d94285d9428473fb999999999999a47bfc999999999999a655d9428473fd333333333333347bfd999999999999a65658c0e6c6f63\
    616c5f626f64795f706f73944e8c0e6c696e6b5f626f64795f6c697374944e752e";

/// `os.system("touch pwned")` when loaded by Python.
pub(crate) const EVIL: &str = "\
    8004953b000000000000007d948c03667073948c05706f736978948c0673797374656d9493948c17746f756368202f746d702f77742f6f75742f7077\
    6e65649485945294732e";

#[test]
fn what_numpy_writes_is_read() {
    for (name, hex) in
        [("4", NUMPY_4), ("5", NUMPY_5), ("2", NUMPY_2), ("lists 0", LISTS_0), ("lists 4", LISTS_4)]
    {
        let clip = parse(&bytes(hex)).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!((clip.fps, clip.frames, clip.kick_frame), (30.0, 2, None), "{name}");
        let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(near(&clip.joint_pos, &[0.1, -0.2, 0.3, -0.4]), "{name}: {:?}", clip.joint_pos);
        assert!(near(&clip.body_pos(1)[0], &[0.1, 0.0, 0.7]), "{name}");
        assert!(near(&clip.body_quat(1)[0], &[0.8, 0.0, 0.0, 0.6]), "{name}: x, y, z, w becomes w, x, y, z");
        assert!(clip.body_lin_vel(0)[0][0] > 2.9, "{name}: 0.1 m in a thirtieth of a second");
    }
}

#[test]
fn nothing_of_a_file_is_run() {
    let error = parse(&bytes(EVIL)).expect_err("refused").to_string();
    assert!(
        error.contains("expected numbers, texts and numpy arrays, found the name 'posix.system'"),
        "{error}"
    );
}

#[test]
fn faults_are_named_with_their_place() {
    let good = bytes(NUMPY_4);
    let error = parse(&good[..100]).expect_err("cut off").to_string();
    assert!(error.starts_with("a.pkl: byte ") && error.ends_with("the end of the file"), "{error}");
    let swap = |from: &[u8], to: &[u8]| {
        let at = good.windows(from.len()).position(|w| w == from).expect("there");
        let mut bad = good.clone();
        bad[at..at + to.len()].copy_from_slice(to);
        parse(&bad).expect_err("a fault").to_string()
    };
    assert_eq!(
        swap(b"root_pos", b"toor_pos"),
        "a.pkl: key 'root_pos' is missing; found: dof_pos, fps, link_body_list, local_body_pos, root_rot, toor_pos"
    );
    let error = swap(&0.6f64.to_le_bytes(), &0.1f64.to_le_bytes());
    assert!(error.contains("key 'root_rot': expected unit quaternions, found norm 0.806"), "{error}");
    let error = swap(&0.3f64.to_le_bytes(), &f64::NAN.to_le_bytes());
    assert!(
        error.contains("key 'dof_pos': expected finite numbers of shape [frames, 2], found NaN in frame 1"),
        "{error}"
    );
    let error = swap(&0.3f64.to_le_bytes(), &1e7f64.to_le_bytes());
    assert!(
        error.ends_with("key 'dof_pos': expected numbers from -1e6 to 1e6, found 1e7 in frame 1"),
        "{error}"
    );
    // 3e5 rad in a thirtieth of a second.
    let error = swap(&0.3f64.to_le_bytes(), &3e5f64.to_le_bytes());
    assert!(error.contains("expected speeds up to 1e6 m/s or rad/s, found "), "{error}");
    assert!(swap(b"\x1e", b"\x00").contains("key 'fps': expected 1 to 2000 frames a second, found 0"));
    assert!(swap(b"f8", b"O8").contains("found type 'O8'"));
}

#[test]
fn a_repeated_row_needs_no_more_than_the_shape_allows() {
    let list = |width: usize| [&b"("[..], &b"K\0".repeat(width), b"l"].concat();
    // Is remembered, dropped, and recalled as every row of a list.
    let rows = |row: &[u8], count: usize| [row, b"q\x000(", &b"h\0".repeat(count), b"l"].concat();
    // 40 kB that stand for 800 MB.
    let file = [&b"}(U\x07dof_pos"[..], &rows(&list(10_000), 10_000), b"u."].concat();
    assert_eq!(
        parse(&file).expect_err("refused").to_string(),
        "a.pkl: key 'dof_pos': expected finite numbers of shape [frames, 2], found shape [10000, 10000]"
    );
    let read = |row: &[u8], count: usize| {
        let file = [&rows(row, count)[..], b"."].concat();
        let (machine, top) = Machine::load(&file).expect("a pickle");
        machine.numbers(top, |_| true)
    };
    assert_eq!(read(&list(4), 3), Ok(vec![0.0; 12]));
    // A thousand numbers of one byte.
    let array = [
        &b"cnumpy.core.numeric\n_frombuffer\n(B\xe8\x03\0\0"[..],
        &[7u8; 1000],
        b"cnumpy\ndtype\n(U\x02i1tR(M\xe8\x03tU\x01CtR",
    ]
    .concat();
    assert_eq!(read(&array, 2), Ok(vec![7.0; 2000]));
    for row in [list(1000), array] {
        let found = read(&row, 1100).expect_err("a million numbers in some kB");
        assert!(found.starts_with("shape [1100, 1000] in a file of "), "{found}");
    }
}

#[test]
fn a_given_frame_rate_must_be_the_files_own() {
    let at = |fps| {
        let options = ReadOptions { fps: Some(fps), ..ReadOptions::default() };
        crate::gmr::parse_gmr(&bytes(NUMPY_4), Path::new("a.pkl"), &model(), &spec(), &options)
    };
    assert_eq!(at(30.0).expect("the same").fps, 30.0);
    assert_eq!(
        at(60.0).expect_err("another").to_string(),
        "a.pkl: key 'fps': expected no --fps other than the file's 30 frames a second, found --fps 60"
    );
}

#[test]
fn a_pickle_is_known_by_its_content_and_by_its_name_and_a_folder_may_hold_it() {
    let (model, spec) = (model(), spec());
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, hex) in [("clip.dat", NUMPY_4), ("lists.pkl", LISTS_0)] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes(hex)).expect("written");
        let clip = crate::read_motion(&path, &model, &spec, &ReadOptions::default()).expect(name);
        assert_eq!(clip.frames, 2);
    }
    let csv = "# fps: 50\n0,0,0.7,0,0,0,1,0.1,0.2\n0,0,0.7,0,0,0,1,0.1,0.2\n";
    std::fs::write(folder.path().join("b.csv"), csv).expect("written");
    let library = crate::MotionLibrary::load(folder.path(), &model, &spec, 50.0).expect("a folder");
    let names: Vec<(&str, KickLeg)> = library.clips.iter().map(|c| (c.name.as_str(), c.kick_leg)).collect();
    assert_eq!(
        names.iter().map(|n| n.0).collect::<Vec<_>>(),
        ["b", "lists"],
        "what has another name is no motion"
    );
    assert_eq!(library.clips[1].fps, 50.0, "resampled");
}
