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

/// A kind of device that the program brings along. It is hardware: its path has one owner.
struct OwnScheme
{
    std::string name;
    OpenDevice open;
};

/// Adds a scheme for the rest of the program; openDevice() knows it from now on, with the limits of
/// all devices. Returns false, with the reason in \a error, if the name is not of 1 .. 32 small
/// letters or is taken. From any thread.
bool registerScheme(OwnScheme scheme, std::string& error);

/// Returns true if \a scheme is one of the kit's own or was registered. From any thread.
bool isKnownScheme(const std::string& scheme);

/// Returns all that were registered so far. From any thread.
std::vector<OwnScheme> ownSchemes();

/// Makes \a open what opens `sim:?board=autd3` in this program: emulated units are no part of this
/// library. Before devices are opened.
void setRehearsedAutd3(OpenDevice open);
/// The same, empty where the program has none.
const OpenDevice& rehearsedAutd3();

} // namespace midair::device
