using System.Text;

namespace Snapfit
{
    /// <summary>Puts server-sent events together from the bytes of their stream (WHATWG HTML,
    /// server-sent events). Lines end with LF or CR LF.</summary>
    public sealed class SseParser
    {
        private readonly StringBuilder data = new StringBuilder();
        private byte[] line = new byte[1024];
        private int length;
        private string kind = "";
        private string id;

        /// <summary>The last id that was complete, or null: what to go on after when the
        /// connection breaks. The server gives one before the first event.</summary>
        public string LastId { get; private set; }

        /// <summary>The kind of the event that is complete.</summary>
        public string Kind { get; private set; }

        /// <summary>The data of the event that is complete.</summary>
        public string Data { get; private set; }

        /// <summary>Takes a byte in.</summary>
        /// <returns>Whether an event is complete.</returns>
        public bool Take(byte next)
        {
            if (next != '\n')
            {
                if (length == line.Length)
                {
                    System.Array.Resize(ref line, 2 * length);
                }
                line[length++] = next;
                return false;
            }
            int end = length > 0 && line[length - 1] == '\r' ? length - 1 : length;
            length = 0;
            return end == 0 ? Complete() : TakeField(Encoding.UTF8.GetString(line, 0, end));
        }

        /// <summary>The connection broke: forget what was not complete.</summary>
        public void Reset()
        {
            length = 0;
            kind = "";
            id = LastId;
            data.Length = 0;
        }

        private bool Complete()
        {
            bool isEvent = data.Length > 0;
            LastId = id;
            if (isEvent)
            {
                Kind = kind.Length > 0 ? kind : "message";
                Data = data.ToString(0, data.Length - 1);
            }
            kind = "";
            data.Length = 0;
            return isEvent;
        }

        private bool TakeField(string text)
        {
            int colon = text.IndexOf(':');
            string name = colon < 0 ? text : text.Substring(0, colon);
            string value = colon < 0 ? "" : text.Substring(colon + 1);
            if (value.StartsWith(" "))
            {
                value = value.Substring(1);
            }
            switch (name)
            {
                case "event":
                    kind = value;
                    break;
                case "data":
                    data.Append(value).Append('\n');
                    break;
                case "id":
                    id = value;
                    break;
            }
            return false;
        }
    }
}
