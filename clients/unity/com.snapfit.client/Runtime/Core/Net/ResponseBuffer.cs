using System;
using System.IO;
using System.Threading;
using System.Threading.Tasks;

namespace Snapfit
{
    /// <summary>An answer's bytes, in an array that is used again and grows as needed.</summary>
    public sealed class ResponseBuffer
    {
        /// <summary>Longer answers are refused: 256 MiB, more than any mesh.</summary>
        public const int MaxBytes = 256 * 1024 * 1024;

        /// <summary>An empty one.</summary>
        public ResponseBuffer()
        {
            Bytes = new byte[16 * 1024];
        }

        /// <summary>The bytes; those from <see cref="Count"/> on belong to earlier answers.
        /// </summary>
        public byte[] Bytes { get; private set; }

        /// <summary>How many belong to this answer.</summary>
        public int Count { get; private set; }

        /// <summary>The HTTP status.</summary>
        public int Status { get; internal set; }

        /// <summary>The answer's ETag, or null.</summary>
        public string ETag { get; internal set; }

        /// <summary>A copy of the answer alone.</summary>
        public byte[] ToArray()
        {
            byte[] copy = new byte[Count];
            Array.Copy(Bytes, copy, Count);
            return copy;
        }

        internal void Clear()
        {
            Count = 0;
            Status = 0;
            ETag = null;
        }

        /// <summary>Room behind what is there already.</summary>
        internal ArraySegment<byte> Room()
        {
            if (Count == Bytes.Length)
            {
                if (Count >= MaxBytes)
                {
                    throw new UnreachableException("The answer is longer than any of snapfit's.");
                }
                byte[] larger = new byte[2 * Bytes.Length];
                Array.Copy(Bytes, larger, Count);
                Bytes = larger;
            }
            return new ArraySegment<byte>(Bytes, Count, Bytes.Length - Count);
        }

        internal void Taken(int count)
        {
            Count += count;
        }

        internal async Task FillAsync(Stream stream, CancellationToken token)
        {
            while (true)
            {
                ArraySegment<byte> room = Room();
                int read = await stream.ReadAsync(room.Array, room.Offset, room.Count, token)
                    .ConfigureAwait(false);
                if (read == 0)
                {
                    return;
                }
                Taken(read);
            }
        }
    }
}
