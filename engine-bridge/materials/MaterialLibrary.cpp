#include "engine-bridge/materials/MaterialLibrary.h"

#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/UserEnvironment.h"
#include "haptics/base/text/JsonValue.h"

#include <filesystem>
#include <limits>

namespace midair::bridge
{

namespace
{

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = std::size_t(1) << 20;

/// A number of a material and its key in files.
struct Entry
{
    const char* key;
    double HapticMaterial::*member;
};
constexpr Entry kEntries[] = {{"stiffness_N_m", &HapticMaterial::stiffness_N_m},
                              {"force_N", &HapticMaterial::mostForce_N},
                              {"radius_m", &HapticMaterial::radius_m},
                              {"radiusGrowth", &HapticMaterial::radiusGrowth},
                              {"rateGrowth_Hz_m", &HapticMaterial::rateGrowth_Hz_m},
                              {"roughness", &HapticMaterial::roughness},
                              {"texturePeriod_m", &HapticMaterial::texturePeriod_m},
                              {"lowVibration", &HapticMaterial::lowVibration},
                              {"lowFrequency_Hz", &HapticMaterial::low_Hz},
                              {"highVibration", &HapticMaterial::highVibration},
                              {"highFrequency_Hz", &HapticMaterial::high_Hz}};

HapticMaterial materialOf(const base::JsonValue& value)
{
    value.object({"stiffness_N_m",
                  "force_N",
                  "radius_m",
                  "radiusGrowth",
                  "rateGrowth_Hz_m",
                  "roughness",
                  "texturePeriod_m",
                  "lowVibration",
                  "lowFrequency_Hz",
                  "highVibration",
                  "highFrequency_Hz"});
    constexpr double kMost = std::numeric_limits<double>::max();
    HapticMaterial material;
    for (const Entry& entry : kEntries)
        if (const auto number = value.find(entry.key))
            material.*entry.member = number->number(-kMost, kMost, "a number");
    std::string error;
    if (!material.isValid(&error)) value.fail(error);
    return material;
}

/// Returns the first of the possible places that has the shipped file.
fs::path shippedFile()
{
    std::vector<fs::path> places;
    if (const fs::path own = base::ownFolder(); !own.empty())
        for (const char* place : {MIDAIR_MATERIALS_FROM_LIBRARY, MIDAIR_MATERIALS_FROM_PROGRAM})
            places.push_back((own / place / "materials.json").lexically_normal());
    places.emplace_back(fs::path(MIDAIR_MATERIALS_INSTALLED) / "materials.json");
    places.emplace_back(fs::path(MIDAIR_MATERIALS_SOURCE) / "materials.json");
    std::error_code ignored;
    for (const fs::path& place : places)
        if (fs::exists(place, ignored)) return place;
    return places.back();
}

} // namespace

void MaterialLibrary::add(const std::string& text, const std::string& source)
{
    const base::JsonValue::Json file = base::parseJson(text, source);
    const base::JsonValue root(source, file);
    root.object({"about", "materials"});
    const char* const right = "an object with a material for each name";
    const base::JsonValue all = root.required("materials", right);
    if (!all.json().is_object()) all.wrong(right);
    std::map<std::string, HapticMaterial> read;
    for (const auto& item : all.json().items())
        read[item.key()] = materialOf(*all.find(item.key()));
    for (auto& [name, material] : read)
        _materials[name] = material;
}

void MaterialLibrary::addFile(const std::string& path)
{
    try
    {
        add(base::readRegularFile(path, kMostBytes), path);
    }
    catch (const base::FileError& error)
    {
        _problems.push_back("file of materials '" + path + "' " + error.what());
    }
    catch (const base::InputError& error)
    {
        _problems.push_back(std::string("file of materials: ") + error.what());
    }
}

MaterialLibrary MaterialLibrary::ofUser()
{
    MaterialLibrary library;
    library.addFile(shippedFile().string());
    if (const auto own = base::userVariable("OSG_MIDAIR_MATERIALS"); own && !own->empty())
        library.addFile(*own);
    return library;
}

const HapticMaterial* MaterialLibrary::find(const std::string& name) const
{
    const auto found = _materials.find(name);
    return found == _materials.end() ? nullptr : &found->second;
}

std::vector<std::string> MaterialLibrary::names() const
{
    std::vector<std::string> names;
    for (const auto& [name, material] : _materials)
        names.push_back(name);
    return names;
}

} // namespace midair::bridge
