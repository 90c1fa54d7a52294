//! The list of a recording's channels: topic, type, encoding and rate of each. `docs/recording.md` says what they hold; a
//! test holds that page against this list.

use super::sample;
use super::{json, protobuf};
use foxglove::messages::{FrameTransforms, JointStates, Log, PointCloud, SceneUpdate};
use std::borrow::Cow;

/// Stands for a frame's name in the topic of a channel that each frame has one of.
const FRAME: &str = "<frame>";

/// The schema of a channel's messages, as a recording carries it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Schema {
    /// Name of the type.
    pub name: String,
    /// Language of `data`: `protobuf` (a set of file descriptors) or `jsonschema`.
    pub encoding: &'static str,
    /// The schema itself.
    pub data: Vec<u8>,
}

macro_rules! channels {
    ($($(#[doc = $doc:literal])* $name:ident($type:ty) $format:ident $topic:literal $rate:literal;)*) => {
        /// A channel.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Channel {
            $($(#[doc = $doc])* $name,)*
        }

        /// A message of a channel.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Content {
            $($(#[doc = $doc])* $name($type),)*
        }

        impl Channel {
            /// All channels, in the order of their numbers in a file.
            pub const ALL: &[Self] = &[$(Self::$name,)*];

            /// Its topic; with `<frame>` in it if each frame has such a channel.
            pub const fn topic(self) -> &'static str {
                match self { $(Self::$name => $topic,)* }
            }

            /// How its messages are encoded: `protobuf` or `json`.
            pub const fn encoding(self) -> &'static str {
                match self { $(Self::$name => $format::ENCODING,)* }
            }

            /// When its messages come.
            pub const fn rate(self) -> &'static str {
                match self { $(Self::$name => $rate,)* }
            }

            /// What it holds, one sentence.
            pub fn what(self) -> &'static str {
                match self { $(Self::$name => concat!($($doc),*).trim(),)* }
            }

            /// The name of its messages' type.
            pub fn schema_name(self) -> String {
                match self { $(Self::$name => $format::schema_name::<$type>(),)* }
            }

            /// The schema of its messages.
            pub fn schema(self) -> Schema {
                match self { $(Self::$name => $format::schema::<$type>(),)* }
            }

            /// The message in these bytes.
            ///
            /// # Errors
            /// They are none of this channel's.
            pub fn decode(self, bytes: &[u8]) -> anyhow::Result<Content> {
                match self { $(Self::$name => $format::decode(bytes).map(Content::$name),)* }
            }
        }

        impl Content {
            /// The channel of such messages.
            pub const fn channel(&self) -> Channel {
                match self { $(Self::$name(_) => Channel::$name,)* }
            }

            /// Appends the message's bytes.
            ///
            /// # Errors
            /// It cannot be encoded.
            pub fn encode(&self, bytes: &mut Vec<u8>) -> anyhow::Result<()> {
                match self { $(Self::$name(message) => $format::encode(message, bytes),)* }
            }
        }
    };
}

impl Channel {
    /// The channel of a topic in a file.
    pub fn of_topic(topic: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|channel| match channel.topic().strip_suffix(FRAME) {
            Some(start) => topic.strip_prefix(start).is_some_and(|frame| !frame.is_empty()),
            None => channel.topic() == topic,
        })
    }

    /// Has each frame a channel of this kind?
    pub fn is_of_frame(self) -> bool {
        self.topic().ends_with(FRAME)
    }
}

impl Content {
    /// The message's topic in a file.
    pub fn topic(&self) -> Cow<'static, str> {
        match self {
            Self::Points(cloud) => Cow::Owned(Channel::Points.topic().replace(FRAME, &cloud.frame_id)),
            _ => Cow::Borrowed(self.channel().topic()),
        }
    }
}

channels! {
    /// Where every body truly is, and where the controller believes the object to be: poses in the frame `world`.
    Transforms(FrameTransforms) protobuf "/tf" "50 Hz";
    /// Shapes of all bodies: the robot's links, the table, the object, whatever else stands there; each in its own frame.
    Bodies(SceneUpdate) protobuf "/scene/bodies" "once";
    /// The believed object as a ghost, with the 99 % region of its position on the table and of its yaw.
    Belief(SceneUpdate) protobuf "/scene/belief" "10 Hz";
    /// Contact forces on the hand as arrows, 10 mm a newton, as they truly are.
    Contacts(SceneUpdate) protobuf "/scene/contacts" "50 Hz while the hand is touched";
    /// The surfaces of a body, or of the object where it is believed to be, as points in its frame.
    Points(PointCloud) protobuf "/points/<frame>" "once";
    /// Measured joint angles and the torques that the arm was told and the hand's motors made.
    JointStates(JointStates) protobuf "/joint_states" "50 Hz";
    /// What happened, as lines of text.
    Log(Log) protobuf "/log" "when it happens";
    /// Readings of all joints.
    Joints(sample::Joints) json "/sensors/joints" "500 Hz";
    /// Where the tactile cells are.
    Pads(sample::Pads) json "/sensors/pads" "once";
    /// Images of the tactile pads.
    Tactile(sample::Tactile) json "/sensors/tactile" "as they come: 41.7 Hz for each of 4 pads";
    /// What the ideal contact sensors feel, with `--sensors ideal` alone.
    LinkContacts(sample::LinkContacts) json "/sensors/link_contacts" "when it changes";
    /// The controller's commands: arm torques, hand motors.
    Command(sample::Command) json "/controller/command" "500 Hz";
    /// What the controller thinks: phase, belief with covariance, evidence, touches.
    Status(sample::Status) json "/controller/status" "10 Hz";
    /// A phase of the mission began.
    Phase(sample::PhaseBegun) json "/controller/phase" "when it happens";
    /// A touch began.
    Touch(sample::Touch) json "/controller/touch" "when it happens";
    /// The hand felt something.
    Contact(sample::Contact) json "/controller/contact" "when it happens";
    /// The belief was corrected.
    Update(sample::Update) json "/controller/update" "when it happens";
    /// The mental world was asked, and agreed or not.
    Foretold(sample::Foretold) json "/controller/foretold" "when it happens";
    /// The planner refused a motion.
    Refusal(sample::Refusal) json "/controller/refusal" "when it happens";
    /// The object slips in the hand.
    Slip(sample::Slip) json "/controller/slip" "when it happens";
    /// The mission ended; with the digest.
    End(sample::End) json "/controller/end" "once";
    /// What the bus has carried and suffered so far.
    Bus(sample::Bus) json "/host/bus" "10 Hz";
    /// The controller stopped answering.
    Lost(sample::ControllerLost) json "/host/lost" "when it happens";
    /// Truth: the object's pose.
    ObjectTruth(sample::ObjectTruth) json "/truth/object" "50 Hz";
    /// Truth: forces on the hand's links.
    LinkForces(sample::LinkForces) json "/truth/link_forces" "50 Hz";
    /// Truth: how far the belief is from the object's pose.
    BeliefError(sample::BeliefError) json "/truth/belief_error" "10 Hz";
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    const PAGE: &str = include_str!("../../../docs/recording.md");

    /// Rows of the page whose first cell is a topic, as their cells.
    fn rows(cells: usize) -> Vec<Vec<&'static str>> {
        let split = |line: &'static str| line.trim_matches('|').split('|').map(str::trim).collect::<Vec<_>>();
        PAGE.lines().filter(|line| line.starts_with("| `/")).map(split).filter(|row| row.len() == cells).collect()
    }

    #[test]
    fn the_page_lists_the_channels_as_they_are() {
        let listed = |channel: &Channel| {
            let code = |text: &str| format!("`{text}`");
            let [topic, schema] = [code(channel.topic()), code(&channel.schema_name())];
            [topic, schema, channel.encoding().to_owned(), channel.rate().to_owned(), channel.what().to_owned()]
                .to_vec()
        };
        assert_eq!(rows(5), Channel::ALL.iter().map(listed).collect::<Vec<_>>());
    }

    #[test]
    fn every_schema_is_complete_in_itself_and_every_field_has_a_text_and_a_place_on_the_page() {
        let fields_on_page = rows(2);
        for channel in Channel::ALL.iter().filter(|channel| channel.encoding() == json::ENCODING) {
            let schema: Value = serde_json::from_slice(&channel.schema().data).unwrap();
            assert!(!schema.to_string().contains("$ref"), "{schema}");
            let row = fields_on_page.iter().find(|row| row[0] == format!("`{}`", channel.topic())).unwrap();
            for (name, field) in schema["properties"].as_object().unwrap() {
                assert!(field["description"].is_string(), "{} {name}", channel.topic());
                assert!(name == "tick" || row[1].contains(&format!("`{name}`")), "{} {name}", channel.topic());
            }
        }
        for channel in Channel::ALL.iter().filter(|channel| channel.encoding() == protobuf::ENCODING) {
            assert!(!channel.schema().data.is_empty(), "{}", channel.topic());
        }
    }

    /// One type, which a choice (`oneOf`) and a list of lists have not in Foxglove's reading of JSON schemas.
    fn assert_plain(schema: &Value, name: &str) {
        let kind = schema["type"].as_str().unwrap_or_else(|| panic!("{name}: {schema}"));
        assert!(schema.get("oneOf").is_none(), "{name}: {schema}");
        for (field, inner) in schema["properties"].as_object().into_iter().flatten() {
            assert_plain(inner, &format!("{name}.{field}"));
        }
        if kind == "array" {
            assert_ne!(schema["items"]["type"], "array", "{name}: {schema}");
            assert_plain(&schema["items"], &format!("{name}[]"));
        }
    }

    #[test]
    fn every_schema_in_json_is_one_that_foxglove_reads() {
        for channel in Channel::ALL.iter().filter(|channel| channel.encoding() == json::ENCODING) {
            assert_plain(&serde_json::from_slice(&channel.schema().data).unwrap(), channel.topic());
        }
    }

    #[test]
    fn the_modes_of_the_hand_are_a_list_of_names() {
        let schema: Value = serde_json::from_slice(&Channel::Command.schema().data).unwrap();
        let mode = &schema["properties"]["hand_mode"]["items"];
        assert_eq!(mode["enum"], serde_json::json!(["idle", "position", "velocity", "torque"]));
    }
}
