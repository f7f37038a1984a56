#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

/// Writes glTF models for tests, apart from what reads them: a buffer, accessors, and what a test
/// puts into the JSON.
class GltfModel
{
public:
    using Json = nlohmann::json;

    Json json = {{"asset", {{"version", "2.0"}}}};
    std::string buffer;

    /// Adds an accessor; \a type: "SCALAR", "VEC3", ... Returns its number.
    int floats(const std::vector<float>& values, const std::string& type)
    {
        return accessor(values.data(), values.size(), 5126, type);
    }
    int shorts(const std::vector<std::uint16_t>& values, const std::string& type = "SCALAR")
    {
        return accessor(values.data(), values.size(), 5123, type);
    }
    int bytes(const std::vector<std::uint8_t>& values, const std::string& type)
    {
        return accessor(values.data(), values.size(), 5121, type);
    }

    /// Adds a buffer view; returns its number.
    int view(const void* data, std::size_t size)
    {
        buffer.resize((buffer.size() + 3) / 4 * 4);
        json["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", size}});
        buffer.append(static_cast<const char*>(data), size);
        return static_cast<int>(json["bufferViews"].size()) - 1;
    }

    /// A triangle (0 0 0), (1 0 0), (0 2 0) as mesh 0 of node 0, which is the scene.
    static GltfModel triangle()
    {
        GltfModel model;
        const int places = model.floats({0, 0, 0, 1, 0, 0, 0, 2, 0}, "VEC3");
        const int indices = model.shorts({0, 1, 2});
        model.json["meshes"] = {
            {{"name", "triangle"},
             {"primitives", {{{"attributes", {{"POSITION", places}}}, {"indices", indices}}}}}};
        model.json["nodes"] = {{{"name", "here"}, {"mesh", 0}}};
        model.json["scenes"] = {{{"nodes", {0}}}};
        model.json["scene"] = 0;
        return model;
    }
    Json& primitive() { return json["meshes"][0]["primitives"][0]; }

    std::string gltf() const
    {
        Json all = json;
        if (!buffer.empty())
            all["buffers"] = {{{"byteLength", buffer.size()},
                               {"uri", "data:application/octet-stream;base64," + base64(buffer)}}};
        return all.dump();
    }

    std::string glb() const
    {
        Json all = json;
        if (!buffer.empty()) all["buffers"] = {{{"byteLength", buffer.size()}}};
        std::string text = all.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        std::string bytes = buffer;
        bytes.resize((bytes.size() + 3) / 4 * 4);
        std::string file = "glTF" + number(2) +
                           number(12 + 8 + text.size() + (bytes.empty() ? 0 : 8 + bytes.size())) +
                           number(text.size()) + "JSON" + text;
        if (!bytes.empty()) file += number(bytes.size()) + std::string("BIN\0", 4) + bytes;
        return file;
    }

    static std::string base64(const std::string& bytes)
    {
        const char* letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        std::string text;
        for (std::size_t i = 0; i < bytes.size(); i += 3)
        {
            std::uint32_t three = 0;
            for (std::size_t k = 0; k < 3; ++k)
                three = three << 8 |
                        (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
            for (std::size_t k = 0; k < 4; ++k)
                text += i + k > bytes.size() ? '=' : letters[three >> (18 - 6 * k) & 63U];
        }
        return text;
    }

private:
    template<typename T>
    int accessor(const T* values, std::size_t count, int kind, const std::string& type)
    {
        const std::size_t width = type == "SCALAR" ? 1
                                  : type == "MAT4" ? 16
                                                   : static_cast<std::size_t>(type[3] - '0');
        const int in = view(values, count * sizeof(T));
        json["accessors"].push_back({{"bufferView", in},
                                     {"componentType", kind},
                                     {"count", count / width},
                                     {"type", type}});
        return static_cast<int>(json["accessors"].size()) - 1;
    }

    static std::string number(std::size_t value)
    {
        std::string bytes;
        for (int shift = 0; shift < 32; shift += 8)
            bytes += static_cast<char>(value >> shift);
        return bytes;
    }
};

/// A PNG of 2 x 2 pixels: red and green above, blue and white below.
inline std::string fourPixels()
{
    static const unsigned char bytes[] = {
        0x89, 0x50, 0x4E, 0x47, 0x0D, 0x0A, 0x1A, 0x0A, 0x00, 0x00, 0x00, 0x0D, 0x49, 0x48, 0x44,
        0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x02, 0x08, 0x02, 0x00, 0x00, 0x00, 0xFD,
        0xD4, 0x9A, 0x73, 0x00, 0x00, 0x00, 0x12, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9C, 0x63, 0xF8,
        0xCF, 0xC0, 0xC0, 0x00, 0xC2, 0x0C, 0xFF, 0x81, 0x00, 0x00, 0x1F, 0xEE, 0x05, 0xFB, 0x0B,
        0xD9, 0x68, 0x8B, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4E, 0x44, 0xAE, 0x42, 0x60, 0x82,
    };
    return std::string(reinterpret_cast<const char*>(bytes), sizeof bytes);
}
