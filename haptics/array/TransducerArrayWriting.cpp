// Writes arrays as JSON; TransducerArrayJson.cpp reads it.
#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace midair::haptics
{

namespace
{

using Json = nlohmann::ordered_json;

} // namespace

std::string TransducerArray::toJson() const
{
    std::string error;
    if (!isValid(&error)) throw base::InputError("array '" + name + "' can't be written: " + error);
    Json head;
    head["name"] = name;
    head["frequency_Hz"] = frequency_Hz;
    head["sourceAmplitude_Pa_m"] = sourceAmplitude_Pa_m;
    if (exposureAmplitude_Pa_m > 0.0) head["exposureAmplitude_Pa_m"] = exposureAmplitude_Pa_m;
    head["directivity"] = directivityName(directivity);
    head["ringing"] = ringing_s;
    head["phaseLevels"] = drive.phaseLevels;
    head["amplitudeLevels"] = drive.amplitudeLevels;
    if (!dead.empty()) head["dead"] = dead;

    std::string text = "{\n";
    for (const auto& item : head.items())
        text += fmt::format("  \"{}\": {},\n",
                            item.key(),
                            item.value().dump(-1, ' ', false, Json::error_handler_t::replace));
    text += "  \"transducers\": [\n";
    for (Eigen::Index i = 0; i < positions.cols(); ++i)
    {
        Json item;
        item["position_m"] = {positions(0, i), positions(1, i), positions(2, i)};
        item["normal"] = {normals(0, i), normals(1, i), normals(2, i)};
        item["board"] = board[static_cast<std::size_t>(i)];
        if (phaseOffset_rad.size() > 0) item["phaseOffset_rad"] = phaseOffset_rad[i];
        if (gain.size() > 0) item["gain"] = gain[i];
        text += fmt::format("    {}{}\n", item.dump(), i + 1 < positions.cols() ? "," : "");
    }
    return text + "  ]\n}\n";
}

} // namespace midair::haptics
