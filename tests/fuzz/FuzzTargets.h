#pragma once

#include <cstddef>
#include <cstdint>

/// What is fuzzed. Each aborts when a promise is broken that no input may break; all are run by
/// libFuzzer (FuzzMain.cpp; run.sh) and on the corpus by the tests (ReplayTest.cpp). None of them
/// may crash, hang, leak, or read what was not set.

/// Bytes to a device, cut into transfers by the first bytes: no read outside of them, whole packets
/// are found again after garbage, a field never plays half, the device's answers are packets.
void fuzzProtocol(const std::uint8_t* data, std::size_t size);

/// Datagrams from AUTD3 units and from others: what is no answer to an open question changes
/// nothing and is counted, and a command is settled once.
void fuzzAutd3(const std::uint8_t* data, std::size_t size);

/// Datagrams to emulated AUTD3 units. The first byte says how they are (number, speed), then each
/// has its address, a time before it in 1/4 ms, its length (2) and its bytes. No read outside of
/// them, answers are as long as answers are, and a host that comes afterwards is understood.
void fuzzUnits(const std::uint8_t* data, std::size_t size);

/// A recording's bytes: no read outside of them, every entry is whole, times ascend, reading ends.
void fuzzRecording(const std::uint8_t* data, std::size_t size);

/// A device's name: a list is cut without losing a byte, what is understood is within its limits,
/// and `sim:` and `null:` (nothing else is opened) play what they are sent or say why not.
void fuzzUri(const std::uint8_t* data, std::size_t size);

/// An OBJ file: it is refused by an InputError, or its triangles refer to vertices that are there
/// and are finite, and points can be had of it.
void fuzzObj(const std::uint8_t* data, std::size_t size);

/// An array file: it is refused by an InputError, or the array is valid and comes back the same
/// when it is written and read again.
void fuzzArray(const std::uint8_t* data, std::size_t size);

/// A file of control points: it is refused by an InputError, or every point is finite, its normal
/// of unit length, and a solver solves or refuses it.
void fuzzPoints(const std::uint8_t* data, std::size_t size);

/// An AdapTics pattern: it is refused by an InputError, or it is within its limits, and played at
/// any time it is finite and within 0 .. 1.
void fuzzSensation(const std::uint8_t* data, std::size_t size);

/// A recording of hands: it is refused by an InputError, or times ascend, frames are finite at any
/// time, and it comes back the same when it is written and read again.
void fuzzHands(const std::uint8_t* data, std::size_t size);

/// Point pairs: they are refused by an InputError, or the calibration says that they are of no use,
/// or it is rigid and finite.
void fuzzPairs(const std::uint8_t* data, std::size_t size);

/// A datagram of hands: it is ignored with a reason, or every joint is finite, and near and thin
/// where it is valid; no read outside of it, and the hands are lost in time.
void fuzzOsc(const std::uint8_t* data, std::size_t size);

/// A request for the operator's page, and the texts that it shows: it is answered, nothing is done
/// without the token, and texts stay texts in JSON and in metrics. An address comes back as it is
/// written, and a trusted host is a number or a known name.
void fuzzMonitor(const std::uint8_t* data, std::size_t size);

/// A glTF model, .gltf or .glb: it is refused by a GltfError, or nodes have a place, vertices are
/// finite, triangles refer to them, and a frame's update ends.
void fuzzGltf(const std::uint8_t* data, std::size_t size);

/// The text of a .haptic file, of -O options or of a tag: what is understood is in range after
/// repair().
void fuzzOptions(const std::uint8_t* data, std::size_t size);

/// OSG_MIDAIR_* variables, a line each, "DEVICE=sim:": the same.
void fuzzEnvironment(const std::uint8_t* data, std::size_t size);

/// The properties of our nodes in scene files. The first byte chooses the format (a: .osgt, x:
/// .osgx, else .osgb), the second the class, the others are the values, a line each in text. The
/// file round them is whole, since OSG's own reader is not what is fuzzed. What was read is in
/// range after repair(), and comes back the same when it is written and read again.
void fuzzScene(const std::uint8_t* data, std::size_t size);
