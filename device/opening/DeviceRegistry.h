#pragma once

#include "device/ArrayDevice.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace midair::device
{

class DeviceUri;

using OpenDevice = std::function<std::unique_ptr<ArrayDevice>(DeviceUri&, const DeviceLayout&)>;

/// A kind of device provided by the program. It is hardware: its path has one owner.
struct OwnScheme
{
    std::string name;
    OpenDevice open;
};

/// Adds a scheme for the rest of the program; openDevice() then knows it, with the limits of all
/// devices. Returns false, with the reason in \a error, if the name is not 1 .. 32 lower-case
/// letters or is taken. Any thread.
bool registerScheme(OwnScheme scheme, std::string& error);

/// Returns true if \a scheme is built in or registered. Any thread.
bool isKnownScheme(const std::string& scheme);

/// Returns all registered schemes. Any thread.
std::vector<OwnScheme> ownSchemes();

/// Sets the function that opens `sim:?board=autd3` in this program; emulated units are not part of
/// this library. Call it before devices are opened.
void setRehearsedAutd3(OpenDevice open);
/// Returns that function, empty if the program has none.
const OpenDevice& rehearsedAutd3();

} // namespace midair::device
