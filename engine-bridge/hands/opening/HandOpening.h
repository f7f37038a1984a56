#pragma once

#include "engine-bridge/hands/HandSource.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace midair::bridge
{

/// Makes a hand source of the application's from what stands behind the colon of its URI. Whatever
/// it throws, and null, mean that there is none.
using HandSourceMaker = std::function<std::shared_ptr<HandSource>(const std::string& options)>;

/// From now on openHands() makes the source "NAME:.." by \a make. Returns false, with the reason in
/// \a error, if the name has another form than 1 .. 32 small letters, digits and dashes, or is
/// taken. Any thread.
bool registerHands(const std::string& name, HandSourceMaker make, std::string& error);

/// Returns true if registerHands() knows what stands before the colon of \a uri. Any thread.
bool isOwnHands(const std::string& uri);
/// The registered names. Any thread.
std::vector<std::string> ownHandNames();

/// Returns what is wrong with \a uri if it names no kind of hand source that this program has;
/// empty if it does, or is "" or "none". Opens nothing. \a more: kinds that the caller opens
/// itself, "mouse:".
std::string unknownHands(const std::string& uri, const std::vector<std::string>& more = {});

/// Opens the hand source that \a uri names: "recorded:FILE", "recorded:FILE?loop", "openxr:?..",
/// "osc:?..", or "NAME:.." of registerHands(); null for "" and "none". Throws base::InputError or
/// device::DeviceError, which name the URI, where it can't be opened. \a more: as of
/// unknownHands(), for the error.
std::shared_ptr<HandSource> openHands(const std::string& uri,
                                      const std::vector<std::string>& more = {});

} // namespace midair::bridge
