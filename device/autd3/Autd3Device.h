#pragma once

#include "device/ArrayDevice.h"
#include "device/autd3/Autd3Account.h"
#include "device/autd3/Autd3Options.h"
#include "device/autd3/Autd3Session.h"
#include "device/autd3/DatagramLink.h"
#include "device/autd3/UnitGroup.h"

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace midair::device::autd3
{

/// `autd3:`: AUTD3 units over UDP.
///
/// One thread owns the socket. send() and other calls leave orders in the account, where a newer
/// field replaces a waiting one, and wake the thread. It reopens lost units in the background; they
/// are silent until the next field.
class Autd3Device : public ArrayDevice
{
public:
    /// Opens the link to the units; throws DeviceError, also when the function argument returns
    /// true.
    using LinkOpener = std::function<std::unique_ptr<DatagramLink>(const std::function<bool()>&)>;
    using Figures = Autd3Account::Figures;

    /// Throws DeviceError as Opening does, unless \a wait. \a opener: null, as the options say.
    Autd3Device(const DeviceLayout& layout,
                const Autd3Options& options,
                bool wait = false,
                LinkOpener opener = nullptr);
    ~Autd3Device() override; ///< masks all units and waits at most 0.2 s for their confirmation

    Autd3Device(const Autd3Device&) = delete;
    Autd3Device& operator=(const Autd3Device&) = delete;

    bool send(const DriveSignal& signal) override;
    bool sendSequence(const DriveSequence& sequence) override;
    void silence() override { _account.orderSilence(); }
    /// Acknowledged by all units.
    double confirmed_s() const override
    {
        return _account.read([](const auto& told) { return told.confirmed_s; });
    }
    std::string status() const override;
    DeviceReport report() const override { return _account.report(); }
    DriveAbility ability() const override;
    std::vector<std::complex<float>> played() const override;
    Figures figures() const
    {
        return _account.read([](const auto& told) { return told.figures; });
    }

private:
    void run();
    void connect(bool isBack); ///< throws DeviceError

    const DeviceLayout _layout;
    const Autd3Options _options;
    const LinkOpener _opener;
    const std::string _name;
    Autd3Account _account; ///< any thread
    // Used only by the thread while it runs.
    Refusals _refusals;
    std::unique_ptr<Autd3Session> _session; ///< null: no open units

    std::thread _thread; ///< last, because it uses all others
};

} // namespace midair::device::autd3

namespace midair::device
{
class DeviceUri;

/// Opens `autd3:`.
std::unique_ptr<ArrayDevice> openAutd3(DeviceUri& uri, const DeviceLayout& layout);
} // namespace midair::device
