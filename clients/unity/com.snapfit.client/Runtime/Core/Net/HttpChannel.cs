using System;
using System.IO;
using System.Net;
using System.Net.Http;
using System.Text;
using System.Threading;
using System.Threading.Tasks;

namespace Snapfit
{
    /// <summary>HTTP with the key, limits on time, and errors as exceptions.</summary>
    public sealed class HttpChannel : IDisposable
    {
        private const int Connections = 16;
        private const int NotModified = 304;
        private const int Refusals = 400;

        private readonly HttpClient client;
        private readonly SnapfitOptions options;

        /// <summary>To the server of the options.</summary>
        public HttpChannel(SnapfitOptions options)
        {
            this.options = options;
            // .NET's own limit is two a server: a long poll and an event stream would leave none
            // for anything else.
            ServicePointManager.FindServicePoint(options.Address).ConnectionLimit = Connections;
            HttpClientHandler handler = new HttpClientHandler
            {
                AllowAutoRedirect = false,
                UseCookies = false,
            };
            client = new HttpClient(handler)
            {
                BaseAddress = options.Address,
                Timeout = Timeout.InfiniteTimeSpan,
            };
            client.DefaultRequestHeaders.ExpectContinue = false;
        }

        /// <summary>A key as the header Authorization tells it; null without one.</summary>
        public static string Authorization(SnapfitOptions options)
        {
            return string.IsNullOrEmpty(options.ApiKey) ? null : "Bearer " + options.ApiKey;
        }

        /// <summary>A request that changes nothing.</summary>
        /// <param name="path">With its query.</param>
        /// <param name="into">Gets the answer; its ETag, if it has one, is sent along.</param>
        /// <param name="extraS">Seconds that the answer may take beside the usual time.</param>
        /// <param name="token">Ends it.</param>
        /// <returns>The status: 200, 204 or 304.</returns>
        /// <exception cref="ProblemException">The server said no.</exception>
        /// <exception cref="UnreachableException">No answer came.</exception>
        public Task<int> GetAsync(
            string path, ResponseBuffer into, double extraS, CancellationToken token)
        {
            HttpRequestMessage request = Request(HttpMethod.Get, path);
            if (into.ETag != null)
            {
                request.Headers.TryAddWithoutValidation("If-None-Match", into.ETag);
            }
            return SendAsync(request, into, options.TimeoutS + extraS, token);
        }

        /// <summary>A request that changes something.</summary>
        /// <param name="method">POST, PUT or DELETE.</param>
        /// <param name="path">Of what is to change.</param>
        /// <param name="json">The body, or null.</param>
        /// <param name="into">Gets the answer.</param>
        /// <param name="token">Ends it.</param>
        /// <exception cref="ProblemException">The server said no.</exception>
        /// <exception cref="UnreachableException">No answer came.</exception>
        public Task<int> SendAsync(
            string method, string path, string json, ResponseBuffer into, CancellationToken token)
        {
            HttpRequestMessage request = Request(new HttpMethod(method), path);
            if (json != null)
            {
                request.Content = new StringContent(json, Encoding.UTF8, "application/json");
            }
            return SendAsync(request, into, options.TimeoutS, token);
        }

        /// <summary>A stream that goes on until it is disposed of.</summary>
        /// <param name="path">With its query.</param>
        /// <param name="lastEventId">What the client has already, or null.</param>
        /// <param name="token">Ends the wait for its beginning.</param>
        /// <exception cref="ProblemException">The server said no.</exception>
        /// <exception cref="UnreachableException">No answer came.</exception>
        public async Task<HttpResponseMessage> OpenAsync(
            string path, string lastEventId, CancellationToken token)
        {
            HttpRequestMessage request = Request(HttpMethod.Get, path);
            request.Headers.TryAddWithoutValidation("Accept", "text/event-stream");
            if (lastEventId != null)
            {
                request.Headers.TryAddWithoutValidation("Last-Event-ID", lastEventId);
            }
            using (Deadline deadline = new Deadline(options.TimeoutS, token))
            {
                try
                {
                    HttpResponseMessage response = await client.SendAsync(
                        request, HttpCompletionOption.ResponseHeadersRead, deadline.Token)
                        .ConfigureAwait(false);
                    if ((int)response.StatusCode >= Refusals)
                    {
                        using (response)
                        {
                            ResponseBuffer body = new ResponseBuffer();
                            await ReadAsync(response, body, deadline.Token).ConfigureAwait(false);
                            throw Problem(response, body);
                        }
                    }
                    return response;
                }
                catch (Exception error) when (IsTrouble(error))
                {
                    throw deadline.Explain(error, options.Address);
                }
            }
        }

        /// <summary>Closes its connections.</summary>
        public void Dispose()
        {
            client.Dispose();
        }

        /// <summary>Whether an exception is of the network, and no mistake of ours.</summary>
        internal static bool IsTrouble(Exception error)
        {
            return error is HttpRequestException || error is WebException || error is IOException
                || error is OperationCanceledException || error is ObjectDisposedException
                || error is System.Net.Sockets.SocketException
                || error is System.Net.WebSockets.WebSocketException;
        }

        private HttpRequestMessage Request(HttpMethod method, string path)
        {
            HttpRequestMessage request = new HttpRequestMessage(
                method, new Uri(options.Address, path));
            string authorization = Authorization(options);
            if (authorization != null)
            {
                request.Headers.TryAddWithoutValidation("Authorization", authorization);
            }
            return request;
        }

        private async Task<int> SendAsync(
            HttpRequestMessage request, ResponseBuffer into, double limitS, CancellationToken token)
        {
            using (request)
            using (Deadline deadline = new Deadline(limitS, token))
            {
                try
                {
                    using (HttpResponseMessage response = await client.SendAsync(
                        request, HttpCompletionOption.ResponseHeadersRead, deadline.Token)
                        .ConfigureAwait(false))
                    {
                        await ReadAsync(response, into, deadline.Token).ConfigureAwait(false);
                        return into.Status < Refusals
                            ? into.Status : throw Problem(response, into);
                    }
                }
                catch (Exception error) when (IsTrouble(error))
                {
                    throw deadline.Explain(error, options.Address);
                }
            }
        }

        private static async Task ReadAsync(
            HttpResponseMessage response, ResponseBuffer into, CancellationToken token)
        {
            string tag = into.ETag;
            into.Clear();
            into.Status = (int)response.StatusCode;
            string told = response.Headers.ETag == null ? null : response.Headers.ETag.ToString();
            into.ETag = told ?? (into.Status == NotModified ? tag : null);
            using (Stream stream = await response.Content.ReadAsStreamAsync()
                .ConfigureAwait(false))
            using (token.Register(response.Dispose))
            {
                await into.FillAsync(stream, token).ConfigureAwait(false);
            }
        }

        private static ProblemException Problem(HttpResponseMessage response, ResponseBuffer body)
        {
            body.ETag = null;
            TimeSpan? after = response.Headers.RetryAfter == null
                ? null : response.Headers.RetryAfter.Delta;
            double? afterS = after == null ? (double?)null : after.Value.TotalSeconds;
            return ProblemException.From(body.Status, body.Bytes, body.Count, afterS);
        }
    }
}
