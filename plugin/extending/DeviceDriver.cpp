#include "engine-bridge/extending/ArrayDriver.h"

#include <osgMidair/DeviceDriver>

#include <memory>
#include <utility>

namespace osgMidair
{

namespace
{

/// An application's driver as the libraries call it.
class DriverOfApplication : public midair::bridge::ArrayDriver
{
public:
    explicit DriverOfApplication(osg::ref_ptr<DeviceDriver> driver) : _driver(std::move(driver)) {}

    bool open(const std::string& path,
              const std::map<std::string, std::string>& options,
              const midair::device::DeviceLayout& layout,
              std::string& error) override
    {
        const DeviceDriver::Layout asked{static_cast<unsigned int>(layout.transducers),
                                         layout.board};
        return _driver->open(path, options, asked, error);
    }
    bool play(const unsigned char* phases, const unsigned char* amplitudes) override
    {
        return _driver->play(phases, amplitudes);
    }
    void silence() override { _driver->silence(); }
    bool isReady() const override { return _driver->isReady(); }
    std::string getStatus() const override { return _driver->getStatus(); }
    unsigned int phaseLevels() const override { return _driver->getPhaseLevels(); }
    std::vector<float> amplitudes() const override { return _driver->getAmplitudes(); }
    double fieldsPerSecond() const override { return _driver->getFieldsPerSecond(); }

private:
    const osg::ref_ptr<DeviceDriver> _driver;
};

} // namespace

bool registerDevice(const std::string& scheme, DeviceDriverFactory make, std::string& error)
{
    midair::bridge::ArrayDriverFactory adapted;
    if (make)
        adapted = [make = std::move(make)]() -> std::shared_ptr<midair::bridge::ArrayDriver>
        {
            osg::ref_ptr<DeviceDriver> driver = make();
            return driver ? std::make_shared<DriverOfApplication>(std::move(driver)) : nullptr;
        };
    return midair::bridge::registerDriver(scheme, std::move(adapted), error);
}

} // namespace osgMidair
