//! Animations: GIF, animated PNG, or a folder of numbered PNG files.

use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use paid_files::FileError;

use crate::{Canvas, PlotError};

/// The kind of animation, from the file's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `.gif`: 256 colors a frame; shown everywhere.
    Gif,
    /// `.png` or `.apng`: all colors; larger.
    Apng,
    /// A name without an extension: a folder of `frame_0000.png` and so on. What a longer recording left there goes.
    Folder,
}

impl Kind {
    /// The kind that goes with a file name.
    ///
    /// # Errors
    /// Any other extension.
    pub fn of(path: &Path) -> Result<Self, PlotError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("gif") => Ok(Self::Gif),
            Some("png" | "apng") => Ok(Self::Apng),
            None => Ok(Self::Folder),
            Some(other) => Err(PlotError::Animation {
                expected: "a name that ends in .gif or .png, or a folder".to_owned(),
                found: format!("{} ('.{other}')", path.display()),
            }),
        }
    }
}

enum Sink {
    Gif(Box<gif::Encoder<BufWriter<File>>>),
    Apng(Box<png::Writer<BufWriter<File>>>),
    Folder,
}

/// An animation being written; the file appears under its name when it is finished.
pub struct Animation {
    path: PathBuf,
    temporary: PathBuf,
    size: [usize; 2],
    /// Hundredths of a second a frame; formats hold whole ones, see [`Animation::delay`].
    pace: f64,
    frames: usize,
    expected: usize,
    sink: Option<Sink>,
}

impl Animation {
    /// Starts an animation of `frames` images of `size` pixels (width, height) at `rate` `[Hz]`.
    ///
    /// # Errors
    /// An unknown extension, a size or number of frames that the format cannot hold, a file that cannot be made.
    pub fn create(path: &Path, size: [usize; 2], rate: f64, frames: usize) -> Result<Self, PlotError> {
        let kind = Kind::of(path)?;
        let mut temporary = path.as_os_str().to_owned();
        temporary.push(".part");
        let mut animation = Self {
            path: path.to_owned(),
            temporary: PathBuf::from(temporary),
            size,
            pace: (100.0 / rate).clamp(2.0, 1000.0),
            frames: 0,
            expected: frames,
            sink: None,
        };
        let opened = animation.open(kind);
        animation.sink = Some(animation.written(opened)?);
        Ok(animation)
    }

    fn open(&self, kind: Kind) -> io::Result<Sink> {
        let bad = |what: &str| io::Error::new(io::ErrorKind::InvalidInput, what.to_owned());
        let side = |n: usize| {
            u16::try_from(n).ok().filter(|n| *n > 0).ok_or_else(|| bad("an image of 1 to 65535 pixels"))
        };
        let [width, height] = [side(self.size[0])?, side(self.size[1])?];
        let folder = if kind == Kind::Folder { Some(self.path.as_path()) } else { self.path.parent() };
        if let Some(folder) = folder.filter(|f| !f.as_os_str().is_empty()) {
            fs::create_dir_all(folder)?;
        }
        if kind == Kind::Folder {
            return Ok(Sink::Folder);
        }
        let file = BufWriter::new(File::create(&self.temporary)?);
        if kind == Kind::Gif {
            let mut encoder = gif::Encoder::new(file, width, height, &[]).map_err(io::Error::other)?;
            encoder.set_repeat(gif::Repeat::Infinite).map_err(io::Error::other)?;
            return Ok(Sink::Gif(Box::new(encoder)));
        }
        let count =
            u32::try_from(self.expected).ok().filter(|n| *n > 0).ok_or_else(|| bad("at least one frame"))?;
        let mut encoder = png::Encoder::new(file, u32::from(width), u32::from(height));
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_animated(count, 0).map_err(io::Error::other)?;
        encoder.set_frame_delay(self.delay(), 100).map_err(io::Error::other)?;
        Ok(Sink::Apng(Box::new(encoder.write_header().map_err(io::Error::other)?)))
    }

    /// How long the next image is shown, in hundredths of a second. If a frame is not a whole number of them, the delays differ by one, so
    /// that the whole keeps its pace.
    fn delay(&self) -> u16 {
        let time = |frames: usize| (frames as f64 * self.pace).round();
        (time(self.frames + 1) - time(self.frames)) as u16
    }

    fn written<T>(&self, result: io::Result<T>) -> Result<T, PlotError> {
        result.map_err(|source| {
            // Nothing more can be done if the leftover cannot be removed either.
            let _ = fs::remove_file(&self.temporary);
            FileError { path: self.path.clone(), source }.into()
        })
    }

    /// Adds an image.
    ///
    /// # Errors
    /// An image of another size, one more than announced, or a file that cannot be written.
    pub fn add(&mut self, image: &Canvas) -> Result<(), PlotError> {
        if [image.width(), image.height()] != self.size || self.frames == self.expected {
            return Err(PlotError::Animation {
                expected: format!("{} images of {:?} pixels", self.expected, self.size),
                found: format!("number {} of {:?}", self.frames + 1, [image.width(), image.height()]),
            });
        }
        let delay = self.delay();
        let result = match self.sink.as_mut() {
            Some(Sink::Gif(encoder)) => {
                let [width, height] = self.size.map(|n| n as u16);
                let mut frame = gif::Frame::from_rgb_speed(width, height, image.bytes(), 15);
                frame.delay = delay;
                encoder.write_frame(&frame).map_err(io::Error::other)
            }
            Some(Sink::Apng(writer)) => writer
                .set_frame_delay(delay, 100)
                .and_then(|()| writer.write_image_data(image.bytes()))
                .map_err(io::Error::other),
            Some(Sink::Folder) => {
                let file = self.numbered(self.frames);
                self.frames += 1;
                return image.save(&file);
            }
            None => Ok(()),
        };
        self.frames += 1;
        self.written(result)
    }

    /// The image with this number in a folder.
    fn numbered(&self, number: usize) -> PathBuf {
        self.path.join(format!("frame_{number:04}.png"))
    }

    /// Removes the images of a longer recording that was in the folder before.
    fn remove_the_rest(&self) -> io::Result<()> {
        let rest = (self.frames..).map(|number| self.numbered(number));
        rest.take_while(|file| file.is_file()).try_for_each(fs::remove_file)
    }

    /// Ends the file and gives it its name.
    ///
    /// # Errors
    /// If that fails.
    pub fn finish(mut self) -> Result<(), PlotError> {
        let ended = match self.sink.take() {
            Some(Sink::Gif(encoder)) => encoder
                .into_inner()
                .map_err(io::Error::other)
                .and_then(|mut file| io::Write::flush(&mut file))
                .map(|()| true),
            Some(Sink::Apng(writer)) => writer.finish().map_err(io::Error::other).map(|()| true),
            Some(Sink::Folder) => self.remove_the_rest().map(|()| false),
            None => Ok(false),
        };
        let renamed =
            ended.and_then(|file| if file { fs::rename(&self.temporary, &self.path) } else { Ok(()) });
        self.written(renamed)
    }
}

impl Drop for Animation {
    fn drop(&mut self) {
        // Given up before its end: the part is of no use.
        if self.sink.is_some() {
            let _ = fs::remove_file(&self.temporary);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pictures() -> Vec<Canvas> {
        [[200, 30, 30], [30, 200, 30], [30, 30, 200]].map(|c| Canvas::new(16, 8, c)).into()
    }

    fn write(path: &Path) {
        let mut animation = Animation::create(path, [16, 8], 25.0, 3).expect("begins");
        for picture in pictures() {
            animation.add(&picture).expect("adds");
        }
        assert!(animation.add(&pictures()[0]).is_err(), "only three were announced");
        animation.finish().expect("ends");
    }

    #[test]
    fn a_gif_has_its_frames_colors_and_pace() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("new/a.gif");
        write(&path);
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(File::open(&path).expect("there")).expect("a gif");
        for picture in pictures() {
            let frame = decoder.read_next_frame().expect("decodes").expect("a frame");
            assert_eq!((frame.width, frame.height, frame.delay), (16, 8, 4));
            for (found, expected) in frame.buffer[..3].iter().zip(picture.get(0, 0)) {
                assert!(found.abs_diff(expected) < 6, "{:?}", &frame.buffer[..3]);
            }
        }
        assert!(decoder.read_next_frame().expect("decodes").is_none());
        assert_eq!(fs::read_dir(folder.path().join("new")).expect("there").count(), 1, "no part is left");
    }

    #[test]
    fn a_rate_between_whole_delays_is_kept_on_average() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let paths = ["a.gif", "a.png"].map(|name| folder.path().join(name));
        for path in &paths {
            let mut animation = Animation::create(path, [16, 8], 40.0, 4).expect("begins");
            for _ in 0..4 {
                animation.add(&pictures()[0]).expect("adds");
            }
            animation.finish().expect("ends");
        }
        // Four frames of 2.5 hundredths of a second.
        let file = File::open(&paths[0]).expect("there");
        let mut decoder = gif::DecodeOptions::new().read_info(file).expect("a gif");
        let delays = [(); 4].map(|()| decoder.read_next_frame().expect("decodes").expect("a frame").delay);
        assert_eq!(delays, [3, 2, 3, 2]);
        // The delay is 20 bytes into a frame's control chunk, behind the chunk's name.
        let bytes = fs::read(&paths[1]).expect("there");
        let chunks = bytes.windows(26).filter(|part| part.starts_with(b"fcTL"));
        let found: Vec<u16> = chunks.map(|part| u16::from_be_bytes([part[24], part[25]])).collect();
        assert_eq!(found, delays);
    }

    #[test]
    fn an_animated_png_has_its_frames() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.png");
        write(&path);
        let file = io::BufReader::new(File::open(&path).expect("there"));
        let mut reader = png::Decoder::new(file).read_info().expect("a png");
        assert_eq!(reader.info().animation_control().map(|c| c.num_frames), Some(3));
        let mut bytes = vec![0; reader.output_buffer_size().expect("small")];
        for picture in pictures() {
            reader.next_frame(&mut bytes).expect("a frame");
            assert_eq!(bytes, picture.bytes());
        }
    }

    #[test]
    fn a_folder_gets_numbered_pictures_and_other_names_are_refused() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        write(&folder.path().join("frames"));
        assert!(folder.path().join("frames/frame_0002.png").is_file());
        // A shorter one in the same folder leaves nothing of the longer one, but keeps files of other programs.
        let frames = folder.path().join("frames");
        fs::write(frames.join("notes.txt"), "mine").expect("written");
        let mut shorter = Animation::create(&frames, [16, 8], 25.0, 1).expect("begins");
        shorter.add(&pictures()[0]).expect("adds");
        shorter.finish().expect("ends");
        let left = |name: &str| frames.join(name).is_file();
        let names = ["frame_0000.png", "frame_0001.png", "frame_0002.png", "notes.txt"];
        assert_eq!(names.map(left), [true, false, false, true]);
        let error =
            Animation::create(Path::new("a.mp4"), [16, 8], 25.0, 3).err().expect("refused").to_string();
        assert_eq!(
            error,
            "record: expected a name that ends in .gif or .png, or a folder, found a.mp4 ('.mp4')"
        );
        let given_up = folder.path().join("b.gif");
        drop(Animation::create(&given_up, [16, 8], 25.0, 3).expect("begins"));
        assert_eq!(fs::read_dir(folder.path()).expect("there").count(), 1, "nothing is left of it");
    }
}
